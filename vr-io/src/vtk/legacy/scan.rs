//! Lines and arrays of a legacy VTK file, one after the other. Numbers are passed over; binary ones are not even read.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use crate::decode::numbers_as_f64;
use crate::error::{FileErrorKind, shown};
use crate::regular_file::{self, RegularFile};
use crate::scalar::{Endian, ScalarType};
use crate::vtk::coded::read_range;
use crate::vtk::words::{self, BadWord};

/// Numbers in the file, not looked at yet.
#[derive(Clone, Debug)]
pub(crate) struct Array {
    /// The name, fit for a line.
    pub name: String,
    pub scalar: ScalarType,
    /// Count of its numbers.
    pub numbers: usize,
    form: Form,
    at: Range<u64>,
    /// Lines of the file that end before it.
    lines_before: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Text,
    /// Big-endian.
    Binary,
    /// Eight in a byte, the highest bit first.
    Bits,
    /// Words from 0 to 1, for bytes from 0 to 255.
    Shares,
}

/// A place in the file.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: u64,
    /// Lines that end before it.
    lines: u64,
    /// True behind the end of a line.
    at_line: bool,
}

/// A file that is read from the beginning to the end.
pub(super) struct Scan {
    file: BufReader<RegularFile>,
    length: u64,
    here: Place,
    pub binary: bool,
}

impl Scan {
    /// The begin of a file, which is text until it says otherwise.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = regular_file::open(path)?;
        let length = file.length()?;
        let here = Place { at: 0, lines: 0, at_line: true };
        Ok(Self { file: BufReader::with_capacity(1 << 16, file), length, here, binary: false })
    }

    /// The next line that is not empty, without blanks around it.
    pub fn line(&mut self) -> Result<Option<String>, FileErrorKind> {
        loop {
            match self.any_line()? {
                Some(line) if line.is_empty() => {}
                found => return Ok(found),
            }
        }
    }

    /// The next line, without blanks around it.
    pub fn any_line(&mut self) -> Result<Option<String>, FileErrorKind> {
        const MAX_LINE: u64 = 1 << 16;
        let mut line = Vec::new();
        (&mut self.file).take(MAX_LINE).read_until(b'\n', &mut line)?;
        self.advance(line.len() as u64, line.ends_with(b"\n").into(), line.ends_with(b"\n"));
        if line.len() as u64 == MAX_LINE && !self.here.at_line {
            let found = String::from_utf8_lossy(&line);
            return Err(FileErrorKind::field(self.place(), found, "a line of text must be shorter"));
        }
        Ok((!line.is_empty()).then(|| String::from_utf8_lossy(line.trim_ascii()).into_owned()))
    }

    /// The next line that is not empty, if it begins with this word.
    pub fn line_of(&mut self, word: &str) -> Result<Option<String>, FileErrorKind> {
        let before = self.here;
        // Where numbers follow instead, they may look like a line of any length.
        let begins = |line: &String| line.get(..word.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(word));
        if let Ok(Some(line)) = self.line()
            && begins(&line)
        {
            return Ok(Some(line));
        }
        self.file.seek(SeekFrom::Start(before.at))?;
        self.here = before;
        Ok(None)
    }

    /// Place of the last line: its number in text, the byte after it in binary files.
    pub fn place(&self) -> String {
        if self.binary {
            format!("byte {}", self.here.at)
        } else {
            format!("line {}", if self.here.at_line { self.here.lines.max(1) } else { self.here.lines + 1 })
        }
    }

    pub fn skip_paragraph(&mut self) -> Result<(), FileErrorKind> {
        while self.any_line()?.is_some_and(|line| !line.is_empty()) {}
        Ok(())
    }

    /// Passes over the numbers of an array, which must all be there.
    pub fn array(&mut self, name: &str, scalar: &str, numbers: usize) -> Result<Array, FileErrorKind> {
        let form = match (self.binary, scalar.eq_ignore_ascii_case("bit")) {
            (false, _) => Form::Text,
            (true, false) => Form::Binary,
            (true, true) => Form::Bits,
        };
        let scalar = type_of(scalar).ok_or_else(|| {
            FileErrorKind::field(
                self.place(),
                scalar,
                "must be a type of numbers, like float, double, int or vtktypeint64",
            )
        })?;
        let begin = self.here;
        let left = self.length.saturating_sub(begin.at);
        let length = match form {
            Form::Text | Form::Shares => None,
            Form::Binary => (numbers as u64).checked_mul(scalar.bytes() as u64),
            Form::Bits => Some((numbers as u64).div_ceil(8)),
        };
        let whole = match (form, length.filter(|&length| length <= left)) {
            (Form::Text | Form::Shares, _) => self.pass_words(numbers)?,
            (_, None) => false,
            (_, Some(length)) => {
                self.file.seek(SeekFrom::Start(begin.at + length))?;
                self.advance(length, 0, false);
                true
            }
        };
        if !whole {
            let allowed = format!("{numbers} numbers of {scalar} are to follow");
            return Err(FileErrorKind::field(format!("array {}", shown(name)), format!("{left} bytes left"), allowed));
        }
        let (at, lines_before) = (begin.at..self.here.at, begin.lines);
        Ok(Array { name: shown(&unescaped(name)), scalar, numbers, form, at, lines_before })
    }

    fn advance(&mut self, bytes: u64, lines: u64, at_line: bool) {
        let Place { at, lines: before, at_line: was } = self.here;
        self.here = Place { at: at + bytes, lines: before + lines, at_line: if bytes == 0 { was } else { at_line } };
    }

    /// Passes to the end of the next `count` words; false where there are fewer.
    fn pass_words(&mut self, count: usize) -> io::Result<bool> {
        let (mut left, mut in_word) = (count, false);
        while left > 0 {
            let buffer = self.file.fill_buf()?;
            if buffer.is_empty() {
                return Ok(left == 1 && in_word);
            }
            let (mut used, mut lines) = (0, 0);
            for c in buffer {
                let blank = c.is_ascii_whitespace();
                if blank && in_word {
                    left -= 1;
                    in_word = false;
                    if left == 0 {
                        break;
                    }
                }
                in_word |= !blank;
                lines += u64::from(*c == b'\n');
                used += 1;
            }
            let at_line = used > 0 && buffer[used - 1] == b'\n';
            self.file.consume(used);
            self.advance(used as u64, lines, at_line);
        }
        Ok(true)
    }
}

impl Array {
    /// Place in the file of numbers that are there as they are, in big-endian order.
    pub fn place_in_file(&self) -> Option<u64> {
        (self.form == Form::Binary).then_some(self.at.start)
    }

    /// The encoding in a word: `ascii` or `raw`.
    pub fn encoding(&self) -> &'static str {
        if matches!(self.form, Form::Text | Form::Shares) { "ascii" } else { "raw" }
    }

    /// This array, of which the words are shares of 255 (`vtkDataReader::ReadCoScalarData`).
    pub(super) fn of_shares(self) -> Self {
        if self.form == Form::Text { Self { form: Form::Shares, scalar: ScalarType::U8, ..self } } else { self }
    }

    /// All its numbers.
    pub fn numbers(&self, path: &Path) -> Result<Vec<f64>, FileErrorKind> {
        if self.form == Form::Text {
            let text = read_range(path, &self.at)?;
            return words::numbers(&text, |word| word.parse().ok()).map_err(|e| self.bad_word(&text, &e));
        }
        Ok(numbers_as_f64(&self.bytes(path)?, self.scalar, Endian::Big))
    }

    /// The bytes of all its numbers, in big-endian order.
    pub fn bytes(&self, path: &Path) -> Result<Vec<u8>, FileErrorKind> {
        let bytes = read_range(path, &self.at)?;
        match self.form {
            Form::Binary => Ok(bytes),
            Form::Text => words::bytes(&bytes, self.scalar, Endian::Big).map_err(|e| self.bad_word(&bytes, &e)),
            Form::Shares => {
                let shares = words::numbers(&bytes, |word| word.parse::<f64>().ok());
                let shares = shares.map_err(|e| self.bad_word(&bytes, &e))?;
                Ok(shares.into_iter().map(|share| (share * 255.0 + 0.5) as u8).collect())
            }
            Form::Bits => {
                let bits = bytes.iter().flat_map(|byte| (0..8).rev().map(move |i| byte >> i & 1));
                Ok(bits.take(self.numbers).collect())
            }
        }
    }

    fn bad_word(&self, text: &[u8], bad: &BadWord) -> FileErrorKind {
        let line = 1 + self.lines_before + text[..bad.at].iter().filter(|&&c| c == b'\n').count() as u64;
        let place = format!("line {line}, array {}", self.name);
        FileErrorKind::field(place, &bad.word, format!("must be a number of type {}", self.scalar))
    }
}

/// The type of a name; of bits, that of the bytes that hold them.
fn type_of(name: &str) -> Option<ScalarType> {
    Some(match name.to_ascii_lowercase().as_str() {
        "bit" | "unsigned_char" | "vtktypeuint8" => ScalarType::U8,
        "char" | "signed_char" | "vtktypeint8" => ScalarType::I8,
        "unsigned_short" | "vtktypeuint16" => ScalarType::U16,
        "short" | "vtktypeint16" => ScalarType::I16,
        "unsigned_int" | "vtktypeuint32" => ScalarType::U32,
        // What VTK calls an id, it writes as an int.
        "int" | "vtkidtype" | "vtktypeint32" => ScalarType::I32,
        "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => ScalarType::U64,
        "long" | "long_long" | "vtktypeint64" => ScalarType::I64,
        "float" | "vtktypefloat32" => ScalarType::F32,
        "double" | "vtktypefloat64" => ScalarType::F64,
        _ => return None,
    })
}

/// A name as people know it: in the file, blanks and others are written as `%20`.
fn unescaped(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = name;
    while let Some((before, after)) = rest.split_once('%') {
        bytes.extend_from_slice(before.as_bytes());
        match after.get(..2).and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(b'%');
                rest = after;
            }
        }
    }
    bytes.extend_from_slice(rest.as_bytes());
    String::from_utf8_lossy(&bytes).into_owned()
}
