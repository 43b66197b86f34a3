//! Ready observers: one file per observable.
