# Install rules: find_package(KdStream) works from an install tree.
