"""Parts of the package that need a YADE session."""
