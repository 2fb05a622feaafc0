"""What others would answer: to be written."""
def all_of(document):
    return {}
