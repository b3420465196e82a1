//! The flash behind [`firmware::persist`]: the two sectors of `STORE` in `memory.x`.
//!
//! An emulated chip has no flash to write to: there two small sectors lie in memory that start-up code does not touch. They
//! outlive a reset, and are lost when the emulator ends.

#![allow(unsafe_code)]

pub use device::StoreFlash;

#[cfg(not(feature = "qemu"))]
mod device {
    use core::slice;
    use embedded_storage::nor_flash::{
        ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
    };
    use stm32f4xx_hal::flash::Error;
    use stm32f4xx_hal::pac;
    use stm32f4xx_hal::pac::flash::cr;

    /// Where the two sectors begin in the chip's memory: see `memory.x`.
    const BEGIN: usize = 0x080c_0000;
    /// Number of the first one.
    const FIRST: u8 = 10;
    /// Bytes of a sector.
    const SECTOR: usize = 128 * 1_024;
    /// Bytes of a word.
    const WORD: usize = 4;

    /// What unlocks the registers (RM0090, 3.5.1).
    const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
    /// All errors in the status register: OPERR, WRPERR, PGAERR, PGPERR, PGSERR.
    const ERRORS: u32 = 0xf2;

    /// The last two sectors of the flash.
    pub struct StoreFlash(pac::FLASH);

    impl StoreFlash {
        /// Takes the flash.
        pub fn new(flash: pac::FLASH) -> Self {
            Self(flash)
        }

        /// Erases or writes by words with the registers unlocked.
        ///
        /// The chip does a word at once from 2.7 V on only; with less, what was written may not last (RM0090, 3.6.2).
        fn change(
            &mut self,
            work: impl FnOnce(&pac::FLASH) -> Result<(), Error>,
        ) -> Result<(), Error> {
            // SAFETY: this register is only read, which changes nothing.
            let power = unsafe { pac::PWR::steal() };
            if power.csr().read().pvdo().bit_is_set() {
                return Err(Error::Operation);
            }
            let flash = &self.0;
            while flash.sr().read().bsy().bit_is_set() {}
            // A debugger that has just written the program may leave errors, which would be taken for ours, and the registers
            // unlocked; keys would then lock them for good.
            // SAFETY: a bit written as one takes away the error it stands for, and does nothing else.
            flash.sr().write(|w| unsafe { w.bits(ERRORS) });
            if flash.cr().read().lock().bit_is_set() {
                for key in KEYS {
                    flash.keyr().write(|w| w.key().set(key));
                }
            }
            if flash.cr().read().lock().bit_is_set() {
                return Err(Error::Operation);
            }
            let done = work(flash);
            // Neither erases nor writes any more, and locked.
            flash.cr().write(|w| w.lock().set_bit());
            self.forget();
            done
        }

        /// Takes out of the data cache what was read before (RM0090, 3.4.2: not done by the chip).
        fn forget(&self) {
            let control = self.0.acr();
            control.modify(|_, w| w.dcen().clear_bit());
            control.modify(|_, w| w.dcrst().set_bit());
            control.modify(|_, w| w.dcrst().clear_bit());
            control.modify(|_, w| w.dcen().set_bit());
        }
    }

    /// Sets what is to be done, and nothing else; 32 bits at once.
    fn by_words(flash: &pac::FLASH, what: impl FnOnce(&mut cr::W) -> &mut cr::W) {
        // A register is written upon its value after a reset, which is locked.
        flash
            .cr()
            .write(|w| what(w.psize().psize32()).lock().clear_bit());
    }

    /// Waits for the end, and says how it went.
    fn wait(flash: &pac::FLASH) -> Result<(), Error> {
        // The order to the flash has to be out before its state is read.
        cortex_m::asm::dsb();
        while flash.sr().read().bsy().bit_is_set() {}
        let status = flash.sr().read();
        let errors = [
            (status.pgserr().bit_is_set(), Error::ProgrammingSequence),
            (status.pgperr().bit_is_set(), Error::ProgrammingParallelism),
            (status.pgaerr().bit_is_set(), Error::ProgrammingAlignment),
            (status.wrperr().bit_is_set(), Error::WriteProtection),
            (status.operr().bit_is_set(), Error::Operation),
        ];
        let error = errors.into_iter().find(|(is_set, _)| *is_set);
        error.map_or(Ok(()), |(_, error)| Err(error))
    }

    fn misplaced(_: NorFlashErrorKind) -> Error {
        Error::ProgrammingAlignment
    }

    impl ErrorType for StoreFlash {
        type Error = Error;
    }

    impl ReadNorFlash for StoreFlash {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
            check_read(self, offset, bytes.len()).map_err(misplaced)?;
            let from = (BEGIN + offset as usize) as *const u8;
            // SAFETY: the bytes lie in the two sectors, and nobody changes them while this object is borrowed.
            bytes.copy_from_slice(unsafe { slice::from_raw_parts(from, bytes.len()) });
            Ok(())
        }

        fn capacity(&self) -> usize {
            2 * SECTOR
        }
    }

    impl NorFlash for StoreFlash {
        const WRITE_SIZE: usize = WORD;
        const ERASE_SIZE: usize = SECTOR;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
            check_erase(self, from, to).map_err(misplaced)?;
            self.change(|flash| {
                for sector in from as usize / SECTOR..to as usize / SECTOR {
                    let number = FIRST + sector as u8;
                    // SAFETY: it is the number of one of the two sectors, where no program is.
                    by_words(flash, |w| unsafe { w.ser().set_bit().snb().bits(number) });
                    // The start comes after all else is set (RM0090, 3.6.3).
                    flash.cr().modify(|_, w| w.strt().set_bit());
                    wait(flash)?;
                }
                Ok(())
            })
        }

        // One copy of it in the program.
        #[inline(never)]
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
            check_write(self, offset, bytes.len()).map_err(misplaced)?;
            self.change(|flash| {
                by_words(flash, |w| w.pg().set_bit());
                let (words, _) = bytes.as_chunks::<WORD>();
                let places = (BEGIN + offset as usize..).step_by(WORD);
                for (word, place) in words.iter().zip(places) {
                    // SAFETY: the place lies in the two sectors, at a whole word; no Rust object is there.
                    unsafe { (place as *mut u32).write_volatile(u32::from_le_bytes(*word)) };
                    wait(flash)?;
                }
                Ok(())
            })
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
    pub struct StoreFlash(*mut u8);

    // SAFETY: there is one of these only, because there is one token of the flash, and whoever has it has the memory.
    unsafe impl Send for StoreFlash {}

    impl StoreFlash {
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

    impl ErrorType for StoreFlash {
        type Error = Infallible;
    }

    impl ReadNorFlash for StoreFlash {
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

    impl NorFlash for StoreFlash {
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
