"""pytest adds the folder of this file to sys.path, for the modules that tests share."""
