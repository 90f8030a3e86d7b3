//! USD's text: indented lines, and long arrays of numbers.

use glam::{Quat, Vec2, Vec3};
use std::fmt;
use std::io::{self, Write};

/// Decimals of lengths: a tenth of a millimetre.
pub const LENGTH: u32 = 4;
/// Decimals of unit vectors, quaternions and colours.
pub const UNIT: u32 = 5;

/// Writes lines and arrays.
pub struct Text<'a> {
    out: &'a mut dyn Write,
    depth: usize,
    buffer: Vec<u8>,
}

/// What an array has.
pub trait Item {
    /// Adds the item's text.
    fn put(&self, to: &mut Vec<u8>, decimals: u32);
}

impl<'a> Text<'a> {
    pub fn new(out: &'a mut dyn Write) -> Self {
        Self { out, depth: 0, buffer: Vec::new() }
    }

    pub fn line(&mut self, line: fmt::Arguments<'_>) -> io::Result<()> {
        writeln!(self.out, "{:width$}{line}", "", width = 4 * self.depth)
    }

    /// A line, and a block that [`Text::close`] ends.
    pub fn open(&mut self, line: fmt::Arguments<'_>) -> io::Result<()> {
        self.line(line)?;
        self.line(format_args!("{{"))?;
        self.depth += 1;
        Ok(())
    }

    /// `name = {` for time samples, which [`Text::close`] ends.
    pub fn samples(&mut self, name: &str) -> io::Result<()> {
        self.line(format_args!("{name}.timeSamples = {{"))?;
        self.depth += 1;
        Ok(())
    }

    pub fn close(&mut self) -> io::Result<()> {
        self.depth -= 1;
        self.line(format_args!("}}"))
    }

    /// `name = [items]` and what follows.
    pub fn array<T: Item>(
        &mut self,
        name: &str,
        items: impl IntoIterator<Item = T>,
        decimals: u32,
        after: &str,
    ) -> io::Result<()> {
        write!(self.out, "{:width$}{name} = ", "", width = 4 * self.depth)?;
        self.items(items, decimals)?;
        writeln!(self.out, "{after}")
    }

    /// A time sample of an array.
    pub fn sample<T: Item>(
        &mut self,
        frame: u32,
        items: impl IntoIterator<Item = T>,
        decimals: u32,
    ) -> io::Result<()> {
        write!(self.out, "{:width$}{frame}: ", "", width = 4 * self.depth)?;
        self.items(items, decimals)?;
        writeln!(self.out, ",")
    }

    fn items<T: Item>(
        &mut self,
        items: impl IntoIterator<Item = T>,
        decimals: u32,
    ) -> io::Result<()> {
        let Self { out, buffer, .. } = self;
        buffer.clear();
        buffer.push(b'[');
        for (i, item) in items.into_iter().enumerate() {
            if i > 0 {
                buffer.extend(b", ");
            }
            item.put(buffer, decimals);
            if buffer.len() > 1 << 16 {
                out.write_all(buffer)?;
                buffer.clear();
            }
        }
        buffer.push(b']');
        out.write_all(buffer)
    }
}

/// A number with so many decimals, without zeros at the end. Beyond 10¹³ it is as Rust writes it.
fn fixed(to: &mut Vec<u8>, value: f32, decimals: u32) {
    let power = 10u64.pow(decimals);
    let scaled = f64::from(value) * power as f64;
    if scaled.abs() >= 1e17 || !scaled.is_finite() {
        to.extend(value.to_string().bytes());
        return;
    }
    let rounded = scaled.round() as i64;
    if rounded < 0 {
        to.push(b'-');
    }
    let (whole, mut part) = (rounded.unsigned_abs() / power, rounded.unsigned_abs() % power);
    integer(to, whole);
    if part > 0 {
        to.push(b'.');
        let mut unit = power;
        while part > 0 {
            unit /= 10;
            to.push(b'0' + (part / unit) as u8);
            part %= unit;
        }
    }
}

fn integer(to: &mut Vec<u8>, mut value: u64) {
    let first = to.len();
    loop {
        to.push(b'0' + (value % 10) as u8);
        value /= 10;
        if value == 0 {
            break;
        }
    }
    to[first..].reverse();
}

fn tuple<const N: usize>(to: &mut Vec<u8>, values: [f32; N], decimals: u32) {
    for (i, value) in values.into_iter().enumerate() {
        to.extend(if i == 0 { "(" } else { ", " }.bytes());
        fixed(to, value, decimals);
    }
    to.push(b')');
}

impl Item for f32 {
    fn put(&self, to: &mut Vec<u8>, decimals: u32) {
        fixed(to, *self, decimals);
    }
}

impl Item for u64 {
    fn put(&self, to: &mut Vec<u8>, _: u32) {
        integer(to, *self);
    }
}

impl Item for u32 {
    fn put(&self, to: &mut Vec<u8>, _: u32) {
        integer(to, u64::from(*self));
    }
}

impl Item for Vec2 {
    fn put(&self, to: &mut Vec<u8>, decimals: u32) {
        tuple(to, self.to_array(), decimals);
    }
}

impl Item for Vec3 {
    fn put(&self, to: &mut Vec<u8>, decimals: u32) {
        tuple(to, self.to_array(), decimals);
    }
}

impl Item for Quat {
    /// USD has the real part first.
    fn put(&self, to: &mut Vec<u8>, decimals: u32) {
        tuple(to, [self.w, self.x, self.y, self.z], decimals);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_their_decimals() {
        let text = |value: f32, decimals| {
            let mut to = Vec::new();
            fixed(&mut to, value, decimals);
            String::from_utf8(to).unwrap()
        };
        for (value, decimals, expected) in [
            (0.0, 4, "0"),
            (-0.0, 4, "0"),
            (1.5, 4, "1.5"),
            (-12.345_67, 4, "-12.3457"),
            (-0.000_04, 4, "0"),
            (0.000_06, 4, "0.0001"),
            (0.05, 4, "0.05"),
            (1000.0, 0, "1000"),
            (-0.99999, 5, "-0.99999"),
            (1e20, 4, "100000000000000000000"),
        ] {
            assert_eq!(text(value, decimals), expected, "{value}");
        }
        let mut to = Vec::new();
        Quat::from_xyzw(0.1, -0.2, 0.3, 0.9).put(&mut to, 5);
        assert_eq!(String::from_utf8(to).unwrap(), "(0.9, 0.1, -0.2, 0.3)");
    }
}
