"""The world: trains, track, points, crews, and the compiled kernel that moves them."""
