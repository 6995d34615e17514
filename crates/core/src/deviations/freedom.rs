//! Equivalent degrees of freedom.
