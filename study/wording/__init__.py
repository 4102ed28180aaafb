"""Every sentence that a report makes of typed facts: in English and in Japanese, by one template each, here alone."""
