"""The level crossings on a unit's path: asked to close in time, and part of the movement limit until they have."""
