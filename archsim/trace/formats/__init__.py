"""Text formats of address traces, one module each; `languages.py` knows them all."""
