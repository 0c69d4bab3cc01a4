// Small parts of the orchestrator: parameters, pipeline, subject lists, error table, words for people.

#include <gtest/gtest.h>

#include <csignal>
#include <sstream>

#include "formats/error.h"
#include "orchestrator/error.h"
#include "orchestrator/error_table.h"
#include "orchestrator/pipeline.h"
#include "orchestrator/progress_bar.h"
#include "orchestrator/report.h"
#include "orchestrator/subject_list.h"
#include "stages/geometry/error.h"
#include "store/error.h"

namespace phiz {
namespace {

TEST(Parameter, TextOfANumberIsCanonicalAndReadsBack) {
  const Parameter number{"x", 1.0, "", "", "", -1e300, 1e300, {}, ""};
  for (const double value : {0.1, 1.0 / 3, 1e-300, 123456789.0, -0.5, 1e22}) {
    EXPECT_EQ(std::get<double>(parse_value(number, format_value(value), "x")), value);
  }
  EXPECT_EQ(format_value(-0.0), "0");
  EXPECT_EQ(format_value(0.50), "0.5");
  EXPECT_EQ(format_value(parse_value(number, "5e-1", "x")), "0.5");
  EXPECT_EQ(format_value(true), "true");
}

TEST(Parameter, WhatIsNotOfItsTypeIsRefusedByName) {
  const Parameter whole{"n", std::int64_t{1}, "", "", "", 0, 10, {}, ""};
  for (const char* text : {"", "1.5", "x", "11", "-1", "1 ", " 1", "0x1", "99999999999999999999"}) {
    EXPECT_THROW(parse_value(whole, text, "stage.n"), UsageError) << text;
  }
  const Parameter choice{"c", std::string("mm"), "", "", "", 0, 0, {"mm", "cm"}, ""};
  EXPECT_THROW(parse_value(choice, "m", "stage.c"), UsageError);
  const Parameter text{"t", std::string(), "", "", "", 0, 0, {}, ""};
  EXPECT_THROW(parse_value(text, "caf\xc3\xa9", "stage.t"), UsageError);
  try {
    parse_value(whole, "x", "stage.n");
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "stage.n: 'x' is not whole number from 0 to 10");
  }
}

Task task_named(const std::string& name, std::vector<TaskInput> inputs) {
  Task task;
  task.name = name;
  task.inputs = std::move(inputs);
  task.outputs = {"out"};
  return task;
}

TEST(Pipeline, PutsEachStageAfterThoseItNeeds) {
  const Pipeline pipeline({task_named("c", {output_of("b", "out")}), task_named("b", {output_of("a", "out")}),
                           task_named("d", {scan_input()}), task_named("a", {scan_input()})});
  std::string order;
  for (const Task& task : pipeline.tasks()) order += task.name;
  EXPECT_LT(order.find('a'), order.find('b'));
  EXPECT_LT(order.find('b'), order.find('c'));
  std::string needed;
  for (const Task* task : pipeline.closure("b")) needed += task->name;
  EXPECT_EQ(needed, "ab");
}

TEST(Pipeline, AStageWithAnOptionIsPassedOverUnlessAskedFor) {
  Task extra = task_named("x", {output_of("a", "out")});
  extra.option = "--x";
  const Pipeline pipeline({task_named("a", {scan_input()}), extra, task_named("b", {output_of("a", "out")})});
  const auto names = [](const std::vector<const Task*>& tasks) {
    std::string text;
    for (const Task* task : tasks) text += task->name;
    return text;
  };
  EXPECT_EQ(names(pipeline.closure("")), "ab");
  EXPECT_EQ(names(pipeline.closure("", {"x"})), "axb");
  EXPECT_EQ(names(pipeline.closure("x")), "ax");
}

TEST(Pipeline, TablesThatCannotWorkAreBugs) {
  EXPECT_THROW(Pipeline({task_named("a", {}), task_named("a", {})}), ContractViolation);
  EXPECT_THROW(Pipeline({task_named("a", {output_of("b", "out")})}), ContractViolation);
  EXPECT_THROW(Pipeline({task_named("a", {}), task_named("b", {output_of("a", "none")})}), ContractViolation);
  EXPECT_THROW(Pipeline({task_named("a", {output_of("b", "out")}), task_named("b", {output_of("a", "out")})}),
               ContractViolation);
}

TEST(Pipeline, KeysDependOnEverythingThatMattersAndOnNothingElse) {
  Task task = task_named("a", {scan_input()});
  const InputDigests inputs{{{"scan", compute_digest("x")}}, ".ply"};
  const ParameterValues parameters = {{"p", 1.0}, {"q", std::string("mm")}};
  const Digest key = make_key_text(task, parameters, inputs).key();
  EXPECT_EQ(make_key_text(task, parameters, inputs).key(), key);
  EXPECT_NE(make_key_text(task, {{"p", 2.0}, {"q", std::string("mm")}}, inputs).key(), key);
  EXPECT_NE(make_key_text(task, parameters, {{{"scan", compute_digest("y")}}, ".ply"}).key(), key);
  EXPECT_NE(make_key_text(task, parameters, {inputs.digests, ".obj"}).key(), key);
  task.version = 2;
  EXPECT_NE(make_key_text(task, parameters, inputs).key(), key);
}

TEST(SubjectList, ReadsQuotesCommentsAndAnyLineEnds) {
  const auto rows = parse_subject_list(
      "\xef\xbb\xbfsubject, scan\r\n# a comment, with \"quotes\nx,\"a, \"\"b\"\".ply\"\r\n\n y , c.ply",
      "list.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].fields.at("scan"), "a, \"b\".ply");
  EXPECT_EQ(rows[0].line, 3);
  EXPECT_EQ(rows[1].fields.at("subject"), "y");
  EXPECT_EQ(rows[1].fields.at("scan"), "c.ply");
}

TEST(SubjectList, NamesFileAndLineOfAMistake) {
  for (const char* text :
       {"", "subject\nx\n", "scan\na,b\n", "scan\n\"a\n", "scan,subject\n,x\n", "scan\n\"a\"b\n"}) {
    try {
      parse_subject_list(text, "list.csv");
      ADD_FAILURE() << text;
    } catch (const UsageError& error) {
      EXPECT_EQ(std::string(error.what()).substr(0, 10), "list.csv: ") << error.what();
    }
  }
}

TEST(SubjectList, EveryTruncationEnds) {
  const std::string text = "subject,scan\nx,\"a,\"\"b\"\"\"\n#c\ny,z\n";
  for (std::size_t length = 0; length <= text.size(); ++length) {
    try {
      parse_subject_list(text.substr(0, length), "list.csv");
    } catch (const UsageError&) {
    }
  }
}

int code_of(std::exception_ptr exception) {
  return describe_failure(exception).code;
}

TEST(ErrorTable, EveryLayersErrorHasItsCode) {
  EXPECT_EQ(code_of(std::make_exception_ptr(UsageError("x"))), 2);
  EXPECT_EQ(code_of(std::make_exception_ptr(FormatError("x"))), 4);
  EXPECT_EQ(code_of(std::make_exception_ptr(InvalidInput("x"))), 4);
  EXPECT_EQ(code_of(std::make_exception_ptr(NumericalFailure("x"))), 1);
  EXPECT_EQ(code_of(std::make_exception_ptr(FitRejected("x"))), 14);
  EXPECT_EQ(code_of(std::make_exception_ptr(Interrupted(SIGINT))), 130);
  EXPECT_EQ(code_of(std::make_exception_ptr(Interrupted(SIGTERM))), 143);
  EXPECT_EQ(code_of(std::make_exception_ptr(ContractViolation("x"))), 70);
  EXPECT_EQ(code_of(std::make_exception_ptr(std::bad_alloc())), 1);
  EXPECT_EQ(code_of(std::make_exception_ptr(3)), 70);
  EXPECT_EQ(code_of(std::make_exception_ptr(StoreError(StoreFault::kNoStore, "x"))), 10);
  EXPECT_EQ(code_of(std::make_exception_ptr(StoreError(StoreFault::kUnknownVersion, "x"))), 10);
  EXPECT_EQ(code_of(std::make_exception_ptr(StoreError(StoreFault::kLeaseHeld, "x"))), 11);
  EXPECT_EQ(code_of(std::make_exception_ptr(StoreError(StoreFault::kDamaged, "x"))), 12);
  EXPECT_EQ(code_of(std::make_exception_ptr(StoreError(StoreFault::kFull, "x"))), 13);
  EXPECT_EQ(code_of(std::make_exception_ptr(StoreError(StoreFault::kPermission, "x"))), 13);
}

TEST(ErrorTable, MessagesStayOnOneLine) {
  const Failure failure = describe_failure(std::make_exception_ptr(FormatError("a\nb\x1b[31m", "c\rd")));
  EXPECT_EQ(failure.what, "a b [31m");
  EXPECT_EQ(failure.hint, "c d");
  EXPECT_EQ(format_failure({"dev00", "ingest"}, failure, false),
            "error: ingest [dev00]: a b [31m\nhint: c d\n");
}

TEST(Report, DurationsReadWell) {
  EXPECT_EQ(format_duration(0.838), "0.84 s");
  EXPECT_EQ(format_duration(12.4), "12 s");
  EXPECT_EQ(format_duration(185), "3 min 05 s");
  EXPECT_EQ(format_duration(7800), "2 h 10 min");
}

TEST(ProgressBar, ShowsStageResidualAndTimeLeft) {
  std::ostringstream terminal;
  ProgressBar bar(terminal);
  EXPECT_EQ(bar.format({"dev00", "fit_global"}, 0.5, 0.1234567, 2),
            "dev00 fit_global [############............]  50 %  residual 0.1235  2.00 s left");
  EXPECT_EQ(bar.format({"dev00", "align"}, 0, {}, 0.1), "dev00 align [........................]   0 %");
  bar.begin(20);
  bar.count_subject();
  EXPECT_EQ(bar.format({"x", "align"}, 2, {}, 1),
            "[1/20] x align [########################] 100 %  0.00 s left");
}

TEST(ProgressBar, LeavesTheLineCleanBeforeOtherText) {
  std::ostringstream terminal;
  ProgressBar bar(terminal);
  bar.start({"x", "align"});
  bar.erase();
  EXPECT_TRUE(terminal.str().ends_with("\r\x1b[K"));
  const auto length = terminal.str().size();
  bar.erase();
  EXPECT_EQ(terminal.str().size(), length);
}

}  // namespace
}  // namespace phiz
