//! Fall paths from files.
