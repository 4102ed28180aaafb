"""What is learned: scenarios, runs, reports, benchmarks and the reproductions of published results."""
