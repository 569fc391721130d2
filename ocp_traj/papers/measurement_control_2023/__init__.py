"""Paper A (Measurement and Control, 2023); the text we have does not name its authors."""
