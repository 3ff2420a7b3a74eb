"""The same verified design for very many loops: what varies, how it is computed, what came out."""
