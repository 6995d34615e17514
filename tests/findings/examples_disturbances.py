"""Examples of findings for `test_words`."""

EXAMPLES = []
