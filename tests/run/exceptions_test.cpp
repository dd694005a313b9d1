// Exceptions as errors.
#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "overtet/result.h"

namespace overtet {
namespace {

template <class E>
ErrorCode code_of(const E& thrown) {
  try {
    throw thrown;
  } catch (...) {
    return error_of_exception().code;
  }
}

TEST(Exceptions, WhatIsScarceIsALimit) {
  EXPECT_EQ(code_of(std::bad_alloc()), ErrorCode::limit);
  EXPECT_EQ(code_of(std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again))),
            ErrorCode::limit);
  EXPECT_EQ(code_of(std::runtime_error("pthread_create has failed: Resource temporarily unavailable")),
            ErrorCode::limit);
}

TEST(Exceptions, AnythingElseIsABug) {
  EXPECT_EQ(code_of(std::system_error(std::make_error_code(std::errc::io_error))), ErrorCode::internal);
  EXPECT_EQ(code_of(std::out_of_range("index")), ErrorCode::internal);
  EXPECT_EQ(code_of(7), ErrorCode::internal);
}

}  // namespace
}  // namespace overtet
