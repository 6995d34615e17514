"""The pages of docs/paper need no files. Readers copy each block separately."""

ALONE = True
