"""By how much legs of trains are moved: one model of time for plans and periods, and proofs that nothing fits."""
