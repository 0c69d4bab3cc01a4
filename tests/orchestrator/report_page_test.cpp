#include "orchestrator/commands/report_page.h"

#include <gtest/gtest.h>

namespace phiz {
namespace {

SubjectReport sample(const std::string& name) {
  SubjectReport report;
  report.name = name;
  report.verdict = "good";
  report.scan_path = "<scan>&.ply";
  report.residuals = {100, 0.1, 0.09, 0.3, 0.5};
  report.regions["nose"] = {10, 0.2, 0.2, 0.4, 0.6};
  report.histogram = {0.5, 0.5};
  report.pictures["head.png"] = std::string("\x89PNG", 4);
  StageReport stage;
  stage.name = "fit_global";
  stage.status = "done";
  stage.summary = {{"residual", {3.0, 2.0, 1.0}}, {"rounds", 8}};
  report.stages.push_back(stage);
  return report;
}

TEST(ReportPage, HasAChapterASubjectAndNeedsNoOtherFile) {
  const std::string page = make_report_page({sample("anna"), sample("bert")});
  for (const char* part :
       {"id=\"anna\"", "id=\"bert\"", "nose", "fit_global", "<polyline", "data:image/png;base64,iVBORw=="})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  for (const char* part : {"http:", "https:", "src=\"/", "<link"})
    EXPECT_EQ(page.find(part), std::string::npos) << part;
}

TEST(ReportPage, WhatComesFromFilesIsNoMarkup) {
  const std::string page = make_report_page({sample("anna")});
  EXPECT_EQ(page.find("<scan>"), std::string::npos);
  EXPECT_NE(page.find("&lt;scan&gt;&amp;.ply"), std::string::npos);
}

TEST(ReportPage, SameReportSameBytes) {
  EXPECT_EQ(make_report_page({sample("anna")}), make_report_page({sample("anna")}));
}

}  // namespace
}  // namespace phiz
