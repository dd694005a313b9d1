#include "tests/fuzz/checks.h"
#include "tests/fuzz/targets.h"

namespace overtet::fuzz {

// The folder is not there, so that no .gltf file reads others.
void obj(std::string_view bytes) { check_as_surface("/no/such/folder/x.obj", bytes); }
void off(std::string_view bytes) { check_as_surface("/no/such/folder/x.off", bytes); }
void ply(std::string_view bytes) { check_as_surface("/no/such/folder/x.ply", bytes); }
void stl(std::string_view bytes) { check_as_surface("/no/such/folder/x.stl", bytes); }
void gltf(std::string_view bytes) { check_as_surface("/no/such/folder/x.gltf", bytes); }

}  // namespace overtet::fuzz
