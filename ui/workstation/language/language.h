#pragma once
// The language of the windows. Sources, logs and command line are in English; ui/workstation/language/ja.ts holds the
// Japanese, and can be edited with Qt Linguist.

#include "ui/scene/scene_language.h"

#include <QString>

#include <array>
#include <string>

class QWidget;

namespace retractor::ui {

struct Phrasebook;

struct Language {
    const char* code; ///< ISO 639-1
    const char* name; ///< in the language itself
};

inline constexpr std::array kLanguages { Language { "en", "English" }, Language { "ja", "日本語" } };

/// Sets the language of the windows that are made from now on. @throws InputError when it is none of kLanguages
void set_language(const QString& code);

/// The code of the language that is set; "en" at first.
QString language();

/// What is known of the language that is set, for work on other threads; null in English. It lives as long as the
/// program, and set_language() changes it: windows exist only after that.
const Phrasebook* language_book();

/// The language that a person has chosen, else that of the system where there is a font for it, else English. Needs a
/// QApplication.
QString preferred_language();

/// Keeps the choice for the next start.
void prefer_language(const QString& code);

/// A text of the window in its language; in English where no translation is known.
QString translated(const QString& english);
QString translated(const std::string& english);
QString translated(const char* english);

/// Translates what the window and everything in it shows now: labels, buttons, actions, choices, tool tips.
void translate_texts(QWidget& window);

/// The language for texts in pictures; empty in English, and where no font has the language's letters. It may be used
/// on any thread, while the program lives.
TextLanguage picture_language();

/// Translates title, legend, notes and words of a picture, where there is a font that has the language's letters.
void translate_texts(Scene& scene);

} // namespace retractor::ui
