/// A report as one HTML page that needs nothing else: tables, checks, histograms, pictures inside the file, no scripts.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gradus/io/histogram.hpp"
#include "gradus/io/image.hpp"

namespace gradus {

/// Pieces appear in the order they are added. All texts are plain text: the report escapes them.
class HtmlReport {
  public:
    explicit HtmlReport(const std::string& title, const std::string& subtitle = "");

    void section(const std::string& title);
    void text(const std::string& paragraph);

    /// Columns after the first are set to the right. Short rows are filled up with empty cells.
    /// @throws std::invalid_argument if a row is longer than the header
    void table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows,
               const std::string& caption = "");

    /// A measured value, with the limit it should keep.
    struct Check {
        std::string name, value;
        std::string limit = {};
        std::optional<bool> met = {};    ///< a mark: kept or missed
        std::optional<double> bar = {};  ///< length of a bar beside the value, in [0, 1]
    };
    void checks(std::span<const Check> rows, const std::string& caption = "");

    struct Stage {
        std::string name;
        double seconds = 0;
    };
    void stages(std::span<const Stage> stages);

    void histogram(const HistogramData& histogram, const HistogramStyle& style = {});
    /// Side by side with the same vertical axis, like draw_histograms.
    void histograms(const HistogramData& left, HistogramStyle left_style, const HistogramData& right,
                    HistogramStyle right_style);

    void picture(const std::string& caption, const Image& image);
    /// With a PNG file that is encoded already.
    void picture(const std::string& caption, std::string_view png);

    /// The whole page.
    std::string html() const;

  private:
    std::string title_, subtitle_, body_;
    bool in_section_ = false;
};

}  // namespace gradus
