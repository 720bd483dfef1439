/// A mesh report for machines.
#pragma once

#include "gradus/quality/report.hpp"

namespace gradus {

/// Keys in the order and with the names of the structs; always all of them, null for what was not measured and for
/// numbers that are not finite.
/// @param indent  spaces per level; -1: all on one line
std::string to_json(const MeshReport& report, int indent = 2);

/// The offenders of such a report alone, as under its key "offenders".
std::string to_json(const OffenderReport& report, int indent = 2);

}  // namespace gradus
