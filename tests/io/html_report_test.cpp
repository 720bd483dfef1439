#include "gradus/io/html_report.hpp"

#include <catch2/catch.hpp>
#include <regex>
#include <set>

using namespace gradus;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Whether every element that is opened is closed, in the right order.
bool balanced(const std::string& page) {
    const std::set<std::string> empty{"meta", "img", "line"};
    std::vector<std::string> open;
    const std::regex tag("<(/?)([a-z0-9]+)[^>]*?(/?)>");
    for (std::sregex_iterator it(page.begin(), page.end(), tag), end; it != end; ++it) {
        const std::string name = (*it)[2];
        if (empty.contains(name) || (*it)[3] == "/") continue;
        if ((*it)[1].length() == 0)
            open.push_back(name);
        else if (open.empty() || open.back() != name)
            return false;
        else
            open.pop_back();
    }
    return open.empty();
}

HtmlReport full_report(const std::string& text) {
    HtmlReport report(text, text);
    report.text(text);
    report.section(text);
    report.table({text, "b"}, {{text, text}, {text}}, text);
    report.checks(
        std::vector<HtmlReport::Check>{{text, text, text, true, 0.5}, {text, text, text, false, 7.0}, {text, text}},
        text);
    report.section(text);
    const HistogramData histogram = count_values(std::vector<double>{1, 2, 2, 3}, 3);
    report.histogram(histogram, {.title = text, .x_label = text});
    report.histograms(histogram, {.title = text}, histogram, {.title = text});
    report.picture(text, Image(2, 2));
    report.stages(std::vector<HtmlReport::Stage>{{text, 0.5}, {text, 1.5}});
    return report;
}

}  // namespace

TEST_CASE("a report escapes every text", "[io][property]") {
    const std::string page = full_report("<b a='1' c=\"2\">&\x01").html();
    CHECK_FALSE(contains(page, "<b a"));
    CHECK_FALSE(contains(page, "c=\"2\""));
    CHECK_FALSE(contains(page, ">&\x01"));
    CHECK(contains(page, "<h1>&lt;b a=&#39;1&#39; c=&quot;2&quot;&gt;&amp;</h1>"));
}

TEST_CASE("a report is well formed and needs nothing from elsewhere", "[io]") {
    const std::string page = full_report("text").html();
    CHECK(balanced(page));
    CHECK(page.rfind("<!DOCTYPE html>", 0) == 0);
    CHECK_FALSE(contains(page, "http"));
    CHECK_FALSE(contains(page, "<script"));
    CHECK_FALSE(contains(page, "<link"));
    CHECK(contains(page, "width:50.0%"));
    CHECK(contains(page, "width:100.0%"));
    CHECK(contains(page, "2.00 s"));
    CHECK(balanced(HtmlReport("empty").html()));
    CHECK_THROWS_AS(HtmlReport("t").table({"a"}, {{"1", "2"}}), std::invalid_argument);
}

TEST_CASE("pictures are embedded in base64", "[io][exact]") {
    // The test vectors of RFC 4648, section 10.
    const auto [bytes, text] = GENERATE(table<std::string, std::string>({{"", ""},
                                                                         {"f", "Zg=="},
                                                                         {"fo", "Zm8="},
                                                                         {"foo", "Zm9v"},
                                                                         {"foob", "Zm9vYg=="},
                                                                         {"fooba", "Zm9vYmE="},
                                                                         {"foobar", "Zm9vYmFy"}}));
    HtmlReport report("t");
    report.picture("c", std::string_view(bytes));
    CHECK(contains(report.html(), "src=\"data:image/png;base64," + text + "\">"));
}
