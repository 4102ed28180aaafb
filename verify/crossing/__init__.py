"""Every state of one level crossing, its device, and one train that comes."""
