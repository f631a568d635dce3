"""Reading and writing of files; all file formats are defined in this package."""
