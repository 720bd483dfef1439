/// Parts of HTML reports.
#pragma once

#include <optional>
#include <string>

#include "gradus/gradation/grade.hpp"
#include "gradus/io/html_report.hpp"
#include "gradus/quality/report.hpp"

namespace gradus::app {

/// Everything measured on a mesh: checks, tables, histograms.
void add_mesh(HtmlReport& page, const MeshReport& report);
/// Measures of a size map before and after grading.
void add_gradation(HtmlReport& page, const GradationOptions& options, const GradationResult& result,
                   std::size_t vertices);
void add_stages(HtmlReport& page, const std::vector<StageTime>& stages);
/// Counts of a report as a chart.
HistogramData chart_of(const Histogram& histogram);

}  // namespace gradus::app
