//! Flight simulation.
