// Tests whether a text is well-formed XML, to the extent used by pictures that the program writes:
// elements, attributes and entities; no comments, no CDATA.
#pragma once

#include <gtest/gtest.h>

#include <cctype>
#include <set>
#include <string>
#include <vector>

namespace skywave {

class XmlChecker {
 public:
  explicit XmlChecker(const std::string& text) : text_(text) {}

  testing::AssertionResult Check() {
    while (at_ < text_.size() && problem_.empty()) {
      if (text_[at_] == '<') {
        Tag();
      } else {
        if (open_.empty() && std::isspace(static_cast<unsigned char>(text_[at_])) == 0) {
          problem_ = "text outside of the root";
        }
        Character();
      }
    }
    if (problem_.empty() && !open_.empty()) problem_ = open_.back() + " is not closed";
    if (problem_.empty() && roots_ != 1) problem_ = "there is not one root";
    if (problem_.empty()) return testing::AssertionSuccess();
    return testing::AssertionFailure()
           << problem_ << " at byte " << at_ << ": " << text_.substr(at_ > 60 ? at_ - 60 : 0, 100);
  }

 private:
  char Peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void Skip() {
    while (std::isspace(static_cast<unsigned char>(Peek())) != 0) ++at_;
  }
  std::string Name() {
    const std::size_t start = at_;
    while (std::isalnum(static_cast<unsigned char>(Peek())) != 0 || Peek() == '-' ||
           Peek() == ':') {
      ++at_;
    }
    if (at_ == start) problem_ = "a name is missing";
    return text_.substr(start, at_ - start);
  }
  void Character() {
    if (text_[at_] == '<' || text_[at_] == '\0') problem_ = "a bare reserved character";
    if (text_[at_++] != '&') return;
    const std::size_t end = text_.find(';', at_);
    const std::string entity = text_.substr(at_, end - at_);
    const std::set<std::string> known = {"amp", "lt", "gt", "quot", "apos"};
    if (end == std::string::npos || (!known.contains(entity) && entity[0] != '#')) {
      problem_ = "a bare &";
    }
    at_ = end + 1;
  }
  void Tag() {
    ++at_;
    if (Peek() == '/') {
      ++at_;
      const std::string name = Name();
      if (open_.empty() || open_.back() != name) {
        problem_ = "the end of " + name + " closes nothing";
        return;
      }
      open_.pop_back();
    } else {
      const std::string name = Name();
      roots_ += open_.empty();
      open_.push_back(name);
      Attributes();
      if (Peek() == '/') ++at_, open_.pop_back();
    }
    Skip();
    if (Peek() != '>') problem_ = "> is missing";
    ++at_;
  }
  void Attributes() {
    std::set<std::string> seen;
    for (Skip(); problem_.empty() && Peek() != '>' && Peek() != '/'; Skip()) {
      if (!seen.insert(Name()).second) problem_ = "an attribute is there twice";
      if (Peek() != '=' || text_[at_ + 1] != '"') problem_ = "an attribute has no quoted value";
      at_ += 2;
      while (problem_.empty() && at_ < text_.size() && Peek() != '"') Character();
      ++at_;
    }
  }

  const std::string& text_;
  std::size_t at_ = 0;
  int roots_ = 0;
  std::vector<std::string> open_;
  std::string problem_;
};

inline testing::AssertionResult IsWellFormedXml(const std::string& text) {
  return XmlChecker(text).Check();
}

}  // namespace skywave
