#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <system_error>

#include "overtet/result.h"

namespace overtet {

Error error_of_exception() {
  const auto internal = [](const std::exception& e) {
    return Error{ErrorCode::internal, std::string("Internal error, please report it: ") + e.what() + "."};
  };
  const auto scarce = [] {
    return Error{ErrorCode::limit, "There is not enough memory, or there are too many threads."};
  };
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return {ErrorCode::limit, "There is not enough memory for this model."};
  } catch (const std::system_error& e) {
    // Of threads that cannot be started.
    if (e.code() == std::errc::resource_unavailable_try_again || e.code() == std::errc::not_enough_memory)
      return scarce();
    return internal(e);
  } catch (const std::exception& e) {
    // What oneTBB throws for a thread that cannot be started is told from others by its words only.
    return std::string_view(e.what()).starts_with("pthread_create") ? scarce() : internal(e);
  } catch (...) {
    return {ErrorCode::internal, "Internal error, please report it."};
  }
}

}  // namespace overtet
