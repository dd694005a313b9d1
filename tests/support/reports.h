// Reports, held against docs/report.schema.json.
#pragma once

#include <string>
#include <vector>

namespace overtet::test {

// What is wrong with the reports in these files, a line each; empty when nothing is. Says so when the
// validator (python3-jsonschema) is missing.
std::string wrong_with_reports(const std::vector<std::string>& files);

// The files of the folder that are reports: JSON with "stages".
std::vector<std::string> reports_in(const std::string& folder);

}  // namespace overtet::test
