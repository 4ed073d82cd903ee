"""The modes of the page, one file each."""
