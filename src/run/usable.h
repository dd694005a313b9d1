// What the machine, a control group and a batch system let this process have. Internal to src/run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace overtet {

// The cores that the quotas of control groups allow, as a number with parts: of the groups in `groups` (a
// text like /proc/self/cgroup) and all above them, both versions, mounted at `root` (/sys/fs/cgroup). None:
// no quota.
std::optional<double> cores_of_quota(const std::string& groups, const std::string& root);

// A whole number in the environment, if it is one and positive.
std::optional<std::int64_t> environment_number(const char* name);

// What Slurm gives this process in bytes, if it runs there and the memory is limited.
std::optional<std::int64_t> slurm_memory_bytes();

}  // namespace overtet
