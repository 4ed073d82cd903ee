"""Pure array functions on meshes, one public function a file."""
