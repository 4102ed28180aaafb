"""What makes the generated documents: `python -m documents.interlocking`."""
