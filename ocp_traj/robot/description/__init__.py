"""Robot descriptions as text: URDF, xacro and SRDF, read and checked before anything is built from them."""
