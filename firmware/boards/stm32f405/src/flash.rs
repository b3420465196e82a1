//! The flash behind [`firmware::persist`]: the two sectors of `STORE` in `memory.x`.
//!
//! An emulated chip has no flash to write to: there two small sectors lie in memory that start-up code does not touch. They
//! outlive a reset, and are lost when the emulator ends.

#![allow(unsafe_code)]

pub use device::Kept;

#[cfg(not(feature = "qemu"))]
mod device {
    use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
    use stm32f4xx_hal::flash::{Error, FlashExt, LockedFlash};
    use stm32f4xx_hal::pac;

    /// Where the two sectors begin in the flash: see `memory.x`.
    const BEGIN: u32 = 0xc_0000;
    /// Bytes of a sector.
    const SECTOR: usize = 128 * 1_024;

    /// The last two sectors of the flash.
    pub struct Kept(LockedFlash);

    impl Kept {
        /// Takes the flash.
        pub fn new(flash: pac::FLASH) -> Self {
            Self(LockedFlash::new(flash))
        }

        /// Takes away old errors (a debugger that has just written the program leaves some), which would be taken for ours.
        fn begin() {
            // SAFETY: bits written as one take away the error they stand for; nothing else is touched, and nobody else uses
            // the flash's registers meanwhile.
            unsafe {
                let errors = 0xf2;
                pac::FLASH::steal().sr().write(|w| w.bits(errors));
            }
        }

        /// Takes out of the data cache what was read before (RM0090, 3.4.2: not done by the chip).
        fn end() {
            // SAFETY: switching the cache off and on changes no value; nobody else uses these registers.
            let registers = unsafe { pac::FLASH::steal() };
            registers.acr().modify(|_, w| w.dcen().clear_bit());
            registers.acr().modify(|_, w| w.dcrst().set_bit());
            registers.acr().modify(|_, w| w.dcrst().clear_bit());
            registers.acr().modify(|_, w| w.dcen().set_bit());
        }
    }

    impl ErrorType for Kept {
        type Error = Error;
    }

    impl ReadNorFlash for Kept {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
            ReadNorFlash::read(&mut self.0, BEGIN + offset, bytes)
        }

        fn capacity(&self) -> usize {
            2 * SECTOR
        }
    }

    impl NorFlash for Kept {
        const WRITE_SIZE: usize = 1;
        const ERASE_SIZE: usize = SECTOR;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
            Self::begin();
            let erased = NorFlash::erase(&mut self.0.unlocked(), BEGIN + from, BEGIN + to);
            Self::end();
            erased
        }

        // One copy of it in the program.
        #[inline(never)]
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
            Self::begin();
            let written = NorFlash::write(&mut self.0.unlocked(), BEGIN + offset, bytes);
            Self::end();
            written
        }
    }
}

#[cfg(feature = "qemu")]
mod device {
    use core::convert::Infallible;
    use core::mem::MaybeUninit;
    use core::ptr::addr_of_mut;
    use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
    use firmware::persist::SLOT_BYTES;
    use stm32f4xx_hal::pac;

    /// Bytes of a sector: a mark and one image.
    const SECTOR: usize = (SLOT_BYTES as usize + 12).next_multiple_of(64);

    /// Start-up code neither clears nor fills this section.
    #[unsafe(link_section = ".uninit.flash")]
    static mut BYTES: MaybeUninit<[u8; 2 * SECTOR]> = MaybeUninit::uninit();

    /// Two sectors in memory.
    pub struct Kept(*mut u8);

    // SAFETY: there is one of these only, because there is one token of the flash, and whoever has it has the memory.
    unsafe impl Send for Kept {}

    impl Kept {
        /// Takes the flash, which does nothing here.
        pub fn new(_: pac::FLASH) -> Self {
            Self(addr_of_mut!(BYTES).cast())
        }

        /// The bytes from `offset` on, as places in memory.
        fn places(&self, offset: u32) -> impl Iterator<Item = *mut u8> {
            // The places lie within the array they are taken from.
            (offset as usize..2 * SECTOR).map(|index| self.0.wrapping_add(index))
        }
    }

    impl ErrorType for Kept {
        type Error = Infallible;
    }

    impl ReadNorFlash for Kept {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
            for (byte, place) in bytes.iter_mut().zip(self.places(offset)) {
                // SAFETY: the place is memory that only this object touches; any bits are a byte.
                *byte = unsafe { place.read_volatile() };
            }
            Ok(())
        }

        fn capacity(&self) -> usize {
            2 * SECTOR
        }
    }

    impl NorFlash for Kept {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = SECTOR;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
            for place in self.places(from).take((to - from) as usize) {
                // SAFETY: as in `read`.
                unsafe { place.write_volatile(0xff) };
            }
            Ok(())
        }

        /// As flash does: bits go from one to zero only.
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
            for (byte, place) in bytes.iter().zip(self.places(offset)) {
                // SAFETY: as in `read`.
                unsafe { place.write_volatile(place.read_volatile() & byte) };
            }
            Ok(())
        }
    }
}
