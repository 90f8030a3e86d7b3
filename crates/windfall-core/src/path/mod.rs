//! Fall paths.
