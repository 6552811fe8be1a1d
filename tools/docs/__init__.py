"""The pages of docs/ that are made from the code: options, tables and the gallery."""
