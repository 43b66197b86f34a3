//! The theory profile of a scene.
