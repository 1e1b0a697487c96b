#pragma once
// The language of the texts in pictures. Scenes are made with English texts.

#include "ui/scene/scene.h"

#include <functional>
#include <string>

namespace retractor::ui {

/// Says an English text in another language; a text that it does not know stays English. Empty: all texts stay English.
/// Called on the thread that draws.
using TextLanguage = std::function<std::string(const std::string&)>;

/// The text in that language.
std::string said(const TextLanguage& language, const std::string& english);

/// Says title, legend, notes and words of the scene in that language.
void say_texts(Scene& scene, const TextLanguage& language);

/// The text in lines of at most so many columns. Lines break between words and, in languages without blanks, between
/// letters, but never before a mark that ends a clause. Chinese, Japanese and Korean letters are two columns wide.
/// @param text UTF-8; a word that is wider than a line has a line of its own
std::vector<std::string> in_lines(const std::string& text, std::size_t columns);

} // namespace retractor::ui
