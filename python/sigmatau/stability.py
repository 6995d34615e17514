"""Whether the noise stays the same: dynamic Allan variance."""
