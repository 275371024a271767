//! A scene that the renderer has seen.
