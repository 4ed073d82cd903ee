"""One thin file a command: parse, load, call one method, save, say what was written."""
