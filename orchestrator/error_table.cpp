#include "orchestrator/error_table.h"

#include <array>
#include <new>

#include "formats/error.h"
#include "orchestrator/error.h"
#include "stages/geometry/error.h"
#include "store/error.h"

namespace phiz {
namespace {

constexpr auto kExitCodes = std::to_array<ExitCode>({
    {kExitDone, "done, or nothing to do"},
    {kExitFailed, "a stage failed; anything not listed"},
    {kExitUsage, "bad command line or configuration; nothing ran"},
    {kExitSomeFailed, "finished, some subjects failed"},
    {kExitBadInput, "input unusable (file and place named)"},
    {kExitNoStore, "no store there, or unknown store version"},
    {kExitLeaseHeld, "held by a living process, and --no-wait"},
    {kExitDamaged, "store damaged"},
    {kExitDisk, "disk full or permission"},
    {kExitRejected, "fit rejected by its own checks (wrong object, collapsed, too far)"},
    {kExitBug, "internal bug"},
    {kExitInterrupted, "interrupted: run the same command to continue"},
    {kExitTerminated, "terminated: run the same command to continue"},
});

int code_of(StoreFault fault) {
  switch (fault) {
    case StoreFault::kNoStore:
    case StoreFault::kUnknownVersion:
      return kExitNoStore;
    case StoreFault::kLeaseHeld:
      return kExitLeaseHeld;
    case StoreFault::kDamaged:
    case StoreFault::kMissing:
      return kExitDamaged;
    case StoreFault::kFull:
    case StoreFault::kPermission:
      return kExitDisk;
    case StoreFault::kInvalidName:
      return kExitUsage;
    case StoreFault::kExists:
    case StoreFault::kIo:
      break;
  }
  return kExitFailed;
}

Failure describe(std::exception_ptr exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const UsageError& error) {
    return {kExitUsage, error.what(), error.hint()};
  } catch (const FormatError& error) {
    return {kExitBadInput, error.what(), error.hint()};
  } catch (const InvalidInput& error) {
    return {kExitBadInput, error.what(), error.hint()};
  } catch (const FitRejected& error) {
    return {kExitRejected, error.what(), error.hint()};
  } catch (const StoreError& error) {
    return {code_of(error.fault()), error.what(), error.hint()};
  } catch (const NumericalFailure& error) {
    return {kExitFailed, error.what(), {}};
  } catch (const Interrupted& error) {
    return {128 + error.signal(), error.what(), "run the same command to continue"};
  } catch (const ContractViolation& error) {
    return {kExitBug, std::string("internal bug: ") + error.what(),
            "please report it with the scan if you can"};
  } catch (const std::bad_alloc&) {
    return {kExitFailed, "out of memory", "use fewer threads (-j) or a smaller scan"};
  } catch (const std::exception& error) {
    return {kExitFailed, error.what(), {}};
  } catch (...) {
    return {kExitBug, "internal bug: something that is no exception was thrown", {}};
  }
}

}  // namespace

std::span<const ExitCode> exit_codes() {
  return kExitCodes;
}

Failure describe_failure(std::exception_ptr exception) {
  Failure failure = describe(exception);
  failure.what = to_one_line(std::move(failure.what));
  failure.hint = to_one_line(std::move(failure.hint));
  return failure;
}

std::string to_one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';
  }
  return text;
}

}  // namespace phiz
