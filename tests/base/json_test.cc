// JSON from text and to text (base/json.h).
#include "base/json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace skywave {
namespace {

constexpr const char* kText = R"({"zebra":1,"ant":[2.5,null,"µ"]})";

TEST(Json, KeepsTheOrderOfMembersWhereItIsAskedTo) {
  EXPECT_EQ(JsonText(ParseOrderedJson(kText)), kText);
  EXPECT_EQ(JsonText(ParseJson(kText)), R"({"ant":[2.5,null,"µ"],"zebra":1})");
}

TEST(Json, IsIndentedOnlyWhereItIsAskedTo) {
  EXPECT_EQ(JsonText(ParseOrderedJson(R"({"a":[1]})"), 1), "{\n \"a\": [\n  1\n ]\n}");
}

// Names of files and of objects of a scene may be any bytes, and a report of them must not fail.
TEST(Json, ReplacesBytesThatAreNotUtf8) {
  const std::string name = "caf\xe9";
  EXPECT_EQ(JsonText(nlohmann::json{{"name", name}}), "{\"name\":\"caf\xef\xbf\xbd\"}");
  EXPECT_EQ(JsonText(nlohmann::ordered_json{{"name", name}}), "{\"name\":\"caf\xef\xbf\xbd\"}");
}

TEST(Json, WritesAsciiWhereItIsAskedTo) {
  EXPECT_EQ(JsonText(nlohmann::ordered_json("µ"), -1, JsonCharacters::kAscii), R"("\u00b5")");
}

TEST(Json, RefusesWhatIsNotJson) {
  EXPECT_THROW(ParseJson("{"), nlohmann::json::exception);
  EXPECT_THROW(ParseOrderedJson("[1,]"), nlohmann::json::exception);
}

}  // namespace
}  // namespace skywave
