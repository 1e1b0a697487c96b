#pragma once
// Phrases in another language. Qt's own translator knows whole texts only; most texts of this window are composed by
// the libraries, which speak English ("Shows 35 % of the aneurysm."), so that a phrase may leave places open.

#include <QHash>
#include <QRegularExpression>
#include <QString>

#include <vector>

class QIODevice;

namespace retractor::ui {

/// A phrase with open places: "Shows %1 % of the %2." and its translation "%2の %1 % が見えます。".
struct OpenPhrase {
    QRegularExpression english; ///< its captures are the open places, in the order in which they stand
    QRegularExpression with_clauses; ///< the same, where a place may hold "; "
    std::vector<int> places; ///< the number of each capture: 1 for %1
    QString translation;
    QString source; ///< the English phrase
    int letters = 0; ///< of the English phrase, without its places
};

/// What a file of translations says.
struct Phrasebook {
    QHash<QString, QString> phrases; ///< English to translation
    std::vector<OpenPhrase> open_phrases; ///< the one with most letters first, because it says most
};

/// Reads a file of Qt Linguist (.ts). @throws InputError naming the line where it is not one
Phrasebook read_phrasebook(QIODevice& file);

/// The text in the language of the book: the phrase, else line by line a phrase with open places (what stands in them
/// is translated too), else sentence by sentence, clause by clause, or name by name of a list.
/// @returns what the book does not know unchanged
QString translated(const Phrasebook& book, const QString& english);

} // namespace retractor::ui
