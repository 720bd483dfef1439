/// What commands print for machines. Keys keep their order; numbers that are not finite become null.
#pragma once

#include <nlohmann/json.hpp>

#include "gradus/control/sizing.hpp"
#include "gradus/gradation/grade.hpp"
#include "gradus/mesh/repair.hpp"
#include "gradus/quality/report.hpp"
#include "session.hpp"

namespace gradus::app {

using Json = nlohmann::ordered_json;

Json json_of(const SizingRule& rule);
Json json_of(const GradationReport& report);
Json json_of(const GradationOptions& options, const GradationResult& result);
Json json_of(const MeshReport& report);
Json json_of(const OffenderReport& report);
Json json_of(const RequiredElements& required);  // how many
Json json_of(const std::vector<StageTime>& stages);
Json json_of(const std::vector<RepairStep>& steps);

/// Prints an object with --json.
void print(const Session& session, const Json& json);
/// Writes an object to a file.
void write(const std::string& path, const Json& json);

}  // namespace gradus::app
