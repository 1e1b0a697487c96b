#pragma once
// A page (HTML) in another language.

#include "ui/workstation/language/phrasebook.h"

#include <filesystem>
#include <string>

namespace retractor::ui {

/// The page with the texts between its tags as the book has them. Scripts, styles, attributes and what the book does
/// not know stay. @param language of the result, for <html lang>
std::string translated_page(const Phrasebook& book, const std::string& page, const std::string& language);

/// Rewrites a page as translated_page(). @throws IoError
void translate_page(const std::filesystem::path& file, const Phrasebook& book, const std::string& language);

} // namespace retractor::ui
