"""Records with missing samples: expected Allan variances of clusters that are not full."""
