// Tests that what files hold reaches terminals as plain text.
#include "base/error.h"

#include <gtest/gtest.h>

#include <string>

namespace skywave {
namespace {

TEST(Messages, KeepTextAndLoseWhatTerminalsObey) {
  for (const std::string text :
       {"plain", "\xC3\xA4\xC2\xB5", "\xE2\x82\xAC \xEF\xBF\xBD", "\xF0\x9F\x98\x80", ""}) {
    EXPECT_EQ(WithoutControlCodes(text), text);
  }
  EXPECT_EQ(WithoutControlCodes("\x1B[31mred\x7F\t"), "?[31mred??");
  EXPECT_EQ(WithoutControlCodes("\xC2\x9B"
                                "1m"),
            "?1m")
      << "a code of two bytes";
}

TEST(Messages, AreUtf8) {
  // A byte of no character; one that is cut short; one longer than need be; half of a pair of
  // UTF-16; beyond the last character.
  EXPECT_EQ(WithoutControlCodes("a\xFF"
                                "b"),
            "a?b");
  EXPECT_EQ(WithoutControlCodes("\xE2\x82"), "??");
  EXPECT_EQ(WithoutControlCodes("\xC0\xAF"), "??");
  EXPECT_EQ(WithoutControlCodes("\xE0\x80\x80"), "???");
  EXPECT_EQ(WithoutControlCodes("\xED\xA0\x80"), "???");
  EXPECT_EQ(WithoutControlCodes("\xF4\x90\x80\x80"), "????");
  EXPECT_EQ(WithoutControlCodes("\xF0\x8F\x80\x80"), "????");
}

// Details of a message stand on lines of their own; a name cannot begin a line like a message does.
TEST(Messages, BreakLinesBeforeDetailsOnly) {
  const InputError error(InputPosition::File("a.obj"), "has no triangle\n  why: a\nb");
  EXPECT_STREQ(error.what(), "a.obj: has no triangle\n  why: a?b");
  EXPECT_EQ(error.reason(), "has no triangle\n  why: a?b");
  EXPECT_EQ(WithoutControlCodes("name\n  of a mesh"), "name?  of a mesh");
}

TEST(Messages, OfMissingFilesKnowTheirNames) {
  const InputError error = InputError::NoSuchFile(InputPosition::Line("a.obj", 3), "b.mtl");
  EXPECT_STREQ(error.what(), "a.obj:3: there is no file \"b.mtl\"");
  EXPECT_EQ(error.missing_file(), "b.mtl");
  EXPECT_EQ(error.exit_code(), kExitIo);
  EXPECT_EQ(InputError(InputPosition::File("a"), "why").missing_file(), "");
}

}  // namespace
}  // namespace skywave
