// What killed workers leave: files without their name yet, where the file system has no nameless files, or in
// the instant in which one gets its name.
#pragma once

#include <set>
#include <string>

namespace overtet {

// Removes, in a folder and below, the unfinished neighbours of these files (paths). Nothing else is touched,
// and nobody must be writing these files.
void remove_leftovers(const std::string& folder, const std::set<std::string>& files);

// The file that a name in the same folder is the unfinished neighbour of: of ".a.mesh.4711.0" and of
// ".a.mesh.Xy12ab" it is "a.mesh". Empty where it is none.
std::string finished_name(const std::string& name);

}  // namespace overtet
