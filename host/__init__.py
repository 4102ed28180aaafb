"""Where a machine runs: devices, their durable state, processes and the planes between them."""
