//! Shadows: seen from one sphere, another hides the spheres that cannot be touched past it.

use std::sync::OnceLock;

/// Pixels along each side of the square around a sphere.
const PIXELS: usize = 16;

/// A set of pixels.
pub(super) type Mask = [u64; PIXELS * PIXELS / 64];

/// Largest distance of a displacement from its pixel by rounding to single precision.
const BLUR: f64 = 1e-5;

/// The pixels in which a sphere is hidden behind a nearer one in another pixel.
#[derive(Debug)]
pub(super) struct Shadows {
    /// For each pixel those that a sphere anywhere in it hides.
    behind: Box<[Mask; PIXELS * PIXELS]>,
    /// Pixels in which spheres can be touched.
    all: Mask,
}

#[inline]
pub(super) fn contains(mask: &Mask, pixel: usize) -> bool {
    mask[pixel / 64] >> (pixel % 64) & 1 == 1
}

/// The pixel of a displacement of at most about one diameter.
#[inline]
pub(super) fn pixel(displacement: [f32; 2]) -> usize {
    // Adding this leaves an integer in the low bits: quicker than a conversion that saturates.
    const INTEGER: f32 = 1.5 * (1_u32 << 23) as f32;
    let [first, second] = displacement.map(|value| {
        // Rounding to the nearest, half a pixel lower, is truncation.
        let pixel = (value + 1.0) * (0.5 * PIXELS as f32) - 0.5 + INTEGER;
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)]
        let pixel = (pixel.to_bits().cast_signed() - INTEGER.to_bits().cast_signed())
            .clamp(0, PIXELS as i32 - 1) as usize;
        pixel
    });
    first * PIXELS + second
}

impl Shadows {
    pub(super) fn get() -> &'static Self {
        static SHADOWS: OnceLock<Shadows> = OnceLock::new();
        SHADOWS.get_or_init(Self::new)
    }

    /// Adds the pixels behind a sphere to `hidden`. Returns whether all pixels are hidden.
    #[inline]
    pub(super) fn hide(&self, displacement: [f32; 2], pixel: usize, hidden: &mut Mask) -> bool {
        let squared = displacement[0] * displacement[0] + displacement[1] * displacement[1];
        // A sphere nearly one diameter away may be passed.
        if squared >= 1.0 - 1e-5 {
            return false;
        }
        let behind = &self.behind[pixel % (PIXELS * PIXELS)];
        let mut left = 0;
        for word in 0..hidden.len() {
            hidden[word] |= behind[word];
            left |= self.all[word] & !hidden[word];
        }
        left == 0
    }

    fn new() -> Self {
        /// More than the rounding errors of double precision and of their square roots.
        const MARGIN: f64 = 1e-6;
        let side = 2.0 / PIXELS as f64;
        let corner = |pixel: usize| [pixel / PIXELS, pixel % PIXELS].map(|index| index as f64 * side - 1.0);
        // Least and largest squared distance of points near two squares, the second of them a
        // pixel.
        let distances = |from: [f64; 2], size: f64, blur: f64, pixel: usize| {
            let to = corner(pixel);
            let (mut least, mut largest) = (0.0, 0.0);
            for axis in 0..2 {
                let (below, above) =
                    (to[axis] - from[axis] - size - blur, to[axis] + side - from[axis] + blur);
                let near = below.max(-above).max(0.0);
                let far = above.max(-below);
                (least, largest) = (least + near * near, largest + far * far);
            }
            [least, largest]
        };
        let height = |squared: f64| f64::max(1.0 - squared, 0.0).sqrt();
        let mut all = Mask::default();
        let mut behind = Box::new([Mask::default(); PIXELS * PIXELS]);
        for far in 0..PIXELS * PIXELS {
            let [least, _] = distances([0.0; 2], 0.0, BLUR, far);
            if least > 1.0 + MARGIN {
                continue;
            }
            all[far / 64] |= 1 << (far % 64);
            for (near, hidden) in behind.iter_mut().enumerate() {
                let [_, to_near] = distances([0.0; 2], 0.0, BLUR, near);
                let [_, between] = distances(corner(near), side, 2.0 * BLUR, far);
                // The contacts by way of the near sphere keep the two farther apart than direct
                // contact.
                if between < 1.0 - MARGIN && height(to_near) + height(between) > height(least) + MARGIN {
                    hidden[far / 64] |= 1 << (far % 64);
                }
            }
        }
        Self { behind, all }
    }
}
