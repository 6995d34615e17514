"""The pages of docs/paper need no files. Each block is copied alone by a reader."""

ALONE = True
