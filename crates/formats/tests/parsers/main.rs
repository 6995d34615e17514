//! Tests of the parsers through their public interface.

mod messages;
mod properties;
