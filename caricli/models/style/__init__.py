"""The network that lends a picture the look of another one."""
